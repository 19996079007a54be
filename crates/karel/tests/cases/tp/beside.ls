/PROG  BESIDE
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:L P[1] 50mm/sec CNT50 TB .05sec,CALL ACTION ;
   2:L P[2] 50mm/sec FINE TA .30sec,DO[1]=ON AP_LD20 ;
   3:  DO[2]=ON ;
   4:  WAIT 1.00(sec) ;
   5:  PR[1]=P[2] ;
   6:  PR[1,3]=PR[1,3]+5 ;
   7:  P[1]=PR[1] ;
   8:L P[1] 50mm/sec FINE DB   10.0mm,DO[3]=PULSE,0.1sec RT_LD10 ;
   9:  P[3]=JPOS ;
  10:J P[3] 10% FINE TA 0sec,R[1]=1 ;
  11:C P[1]
    :  P[2] 10mm/sec FINE INC ;
/POS
P[1:"here"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = 900.000 mm,	Y = 0.000 mm,	Z = 700.000 mm,
	W = 180.000 deg,	P = 0.000 deg,	R = 0.000 deg
};
P[2:"here"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'F U T, 0, 0, -1',
	X = 800.000 mm,	Y = 100.000 mm,	Z = 600.000 mm,
	W = 180.000 deg,	P = 0.000 deg,	R = 0.000 deg
};
P[3:"never taught"]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = ********  mm,	Y = ********  mm,	Z = ********  mm,
	W = ******** deg,	P = ******** deg,	R = ******** deg
};
P[4]{
   GP1:
	UF : F, UT : F,
	J1 = ******** deg,	J2 = 20.000 deg,	J3 = -30.000 deg,	J4 = 0.000 deg,	J5 = -60.000 deg,	J6 = 5.000 deg
};
/END
--> load action.ls
