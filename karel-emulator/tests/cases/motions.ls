/PROG  MOTIONS
/ATTR
OWNER = MNEDITOR;
/MN
   1:  !--> set DIN[3]=ON ;
   2:  UFRAME_NUM=0 ;
   3:  UTOOL_NUM=1 ;
   4:  PR[1]=LPOS    ;
   5:  PR[2]=JPOS    ;
   6:  PR[3]=PR[1]    ;
   7:  PR[3,3]=800    ;
   8:  R[1]=200    ;
   9:  J PR[2] 50% FINE    ;
  10:  L PR[3] R[1]mm/sec FINE    ;
  11:  L PR[1] 100cm/min CNT50 ACC80    ;
  12:  J P[1] 100% CNT100 PTH    ;
  13:  PR[4]=PR[1]-PR[1]    ;
  14:  PR[4,1]=(-50)    ;
  15:  L P[1] 300mm/sec FINE Offset,PR[4]    ;
  16:  L P[1] 300mm/sec FINE Tool_Offset,PR[4]    ;
  17:  OFFSET CONDITION PR[4] ;
  18:  L P[1] 300mm/sec FINE Offset    ;
  19:  TOOL_OFFSET CONDITION PR[4] ;
  20:  L P[1] 300mm/sec FINE Tool_Offset    ;
  21:  L P[1] 300mm/sec FINE    ;
  22:  C P[2]    
    :  P[3] 200mm/sec FINE    ;
  23:  SKIP CONDITION DI[3]=ON ;
  24:  L P[1] 50mm/sec FINE Skip,LBL[1]    ;
  25:  R[2]=1    ;
  26:  LBL[1] ;
  27:  UTOOL[2]=PR[4]    ;
  28:  UFRAME[2]=PR[4]    ;
  29:  END ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   985.000  mm,	Y =     0.000  mm,	Z =   850.000  mm,
	W =  -180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[2]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   935.000  mm,	Y =     0.000  mm,	Z =   800.000  mm,
	W =  -180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[3]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =   985.000  mm,	Y =     0.000  mm,	Z =   750.000  mm,
	W =  -180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
/END
