/PROG  TIMERS
/ATTR
OWNER		= MNEDITOR;
DEFAULT_GROUP	= 1,*,*,*,*;
/MN
   1:  TIMER[1]=RESET ;
   2:  TIMER[1]=START ;
   3:  WAIT 1.50(sec) ;
   4:  R[1]=TIMER[1] ;
   5:  TIMER[1]=STOP ;
   6:  WAIT .50(sec) ;
   7:  R[2]=TIMER[1] ;
   8:  TIMER[1]=START ;
   9:  WAIT .25(sec) ;
  10:  R[3]=TIMER[1]+1 ;
  11:  R[5]=1 ;
  12:  IF TIMER[R[5]]>1.7,JMP LBL[1] ;
  13:  R[4]=1 ;
  14:  LBL[1] ;
  15:  TIMER[1]=RESET ;
  16:  WAIT 1.00(sec) ;
  17:  R[6]=TIMER[1] ;
  18:  TIMER[11]=START ;
/POS
/END
