/PROG  BESIDES
/ATTR
OWNER = MNEDITOR;
/MN
   1:  !--> load _note.ls ;
   2:  UFRAME_NUM=0 ;
   3:  UTOOL_NUM=1 ;
   4:  J P[1] 100% FINE    ;
   5:  L P[2] 100mm/sec FINE DB   20.0mm,CALL _NOTE    ;
   6:  R[2]=PR[10,3]-700 ;
   7:  IF (R[2]>18 AND R[2]<=20) THEN ;
   8:  MESSAGE[DB was in time.] ;
   9:  ENDIF ;
  10:  L P[1] 100mm/sec FINE TB    .50sec,CALL _NOTE    ;
  11:  R[2]=800-PR[10,3] ;
  12:  IF (R[2]>30 AND R[2]<50) THEN ;
  13:  MESSAGE[TB was in time.] ;
  14:  ENDIF ;
  15:  TIMER[1]=RESET ;
  16:  L P[2] 100mm/sec CNT100 TA    .30sec,DO[2]=ON    ;
  17:  TIMER[1]=START ;
  18:  L P[1] 100mm/sec FINE    ;
  19:  WAIT DO[2]=ON    ;
  20:  TIMER[1]=STOP ;
  21:  IF (TIMER[1]>.3) THEN ;
  22:  MESSAGE[TA waited.] ;
  23:  ENDIF ;
  24:  DO[3]=PULSE,0.2sec ;
  25:  WAIT DO[3]=OFF-    ;
  26:  SKIP CONDITION DO[4]=ON+    ;
  27:  L P[2] 100mm/sec FINE Skip,LBL[1],PR[10]=LPOS TB .30sec,DO[4]=ON    ;
  28:  R[3]=PR[10,3]-700 ;
  29:  IF (R[3]>5 AND R[3]<30) THEN ;
  30:  MESSAGE[The edge ended the motion.] ;
  31:  ENDIF ;
  32:  LBL[1] ;
  33:  PR[5]=P[3] ;
  34:  P[4]=PR[5] ;
  35:  J P[4] 100% FINE    ;
  36:  C P[5]    
    :  P[6] 100mm/sec FINE INC    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   900.000  mm,	Y =     0.000  mm,	Z =   800.000  mm,
	W =  -180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[2]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   900.000  mm,	Y =     0.000  mm,	Z =   700.000  mm,
	W =  -180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[3]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   900.000  mm,	Y =   100.000  mm,	Z =   700.000  mm,
	W =  -180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[4]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X = ********  mm,	Y = ********  mm,	Z = ********  mm,
	W = ******** deg,	P = ******** deg,	R = ******** deg
};
P[5]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =    50.000  mm,	Y =    50.000  mm,	Z =     0.000  mm,
	W =     0.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[6]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =     0.000  mm,	Y =   100.000  mm,	Z =     0.000  mm,
	W =     0.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
/END
